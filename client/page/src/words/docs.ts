// The page's own texts on /docs. The description of the interface comes from the server, and the documents from the repository.
export const words = {
  title: 'HTTP interface', loading: 'Loading …', absent: 'The server does not answer. Reload the page to try again.', noDocuments: 'The documents could not be loaded.', token: 'This server needs a token', use: 'Use it',
  contents: 'Contents', home: 'Back to the main page', search: 'Search', hint: 'Search ( / )', parameters: 'Parameters', raw: 'For programs:', headers: 'Headers',
  allParameters: (count: number) => `and ${count} fracture parameters`, body: 'Body:',
  kinds: { tutorial: 'First steps', 'how-to': 'How to', reference: 'Reference', explanation: 'Explanation' },
  pictures: 'the pictures are in the repository',
  found: (count: number, shown: number) => (count === 0 ? 'No results. A result must contain all search words.' : count === 1 ? '1 result' : `${count} results${shown < count ? `, showing the best ${shown}` : ''}`),
};
